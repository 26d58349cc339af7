"""From measured spectra back to films."""

"""Small files: read whole, written whole; rows, TOML, measured spectra."""

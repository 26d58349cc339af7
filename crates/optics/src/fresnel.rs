//! Fresnel amplitudes of one interface.

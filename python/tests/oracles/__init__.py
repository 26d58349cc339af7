"""Independent answers to what the renderer should find: numpy, float64, 1 nm sums, no line shared with the renderer.

spectra           observer, light and refractive indices on the 1 nm grid
film              complex amplitudes of one free film
camera            camera rays from the written conventions
environment       latitude-longitude maps: looked up here, written to EXR for the renderer
film_sphere       the closed form of a lone film sphere
polarised_trace   3 x 3 field matrices along every branch through many film spheres
surface_trace     coated and bare faces, refraction, absorption: every branch at one wavelength
comparison        how far a picture is from what an oracle says
mueller           Mueller matrices in explicit frames, to check the field matrices
ztest             z-tests for images with many pixels
"""

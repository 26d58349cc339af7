"""One module a target: it turns films, or a scene, into files and tells how far they are from the truth."""

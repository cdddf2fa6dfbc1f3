"""The study of friction and density in simple shear, run and drawn: see tools/studies/rheology.sh."""

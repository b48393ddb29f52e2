"""Search for the most informative Fourier series within all bounds."""

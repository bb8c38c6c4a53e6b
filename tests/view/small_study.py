"""The exciter and the grid of the small studies that tests of the page explore."""

import numpy as np

import vibropipe as vp

EXCITER = vp.Exciter(l=0.5, h=0.2, delta=0.01, R1=0.7, R2=0.7)
NU, F = np.linspace(0.4, 2.8, 9), np.linspace(0.1, 1.9, 10)

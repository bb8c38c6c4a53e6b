"""Continuation: Newton's method, curves of zeros and what lies on them; it knows residuals and tests, no physics."""

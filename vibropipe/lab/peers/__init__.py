"""Other packages on the same motions, as a user would apply them: solve_ivp of scipy, and heyoka.

They are general integrators: an impact, or an end of a linear piece of a motion with soft supports or friction, is an
event at which the integration stops, or the state or the equation changes. A run whose work exceeds a limit is stopped,
and penetration of a rigid support is detected.
"""

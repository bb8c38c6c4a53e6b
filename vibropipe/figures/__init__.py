"""Style and parts of figures. Only this folder and the pictures of each kind of scene import matplotlib."""

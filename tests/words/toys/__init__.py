"""Records that the program does not know; they are registered before its other modules make lists of them."""

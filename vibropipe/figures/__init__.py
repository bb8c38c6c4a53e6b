"""Style and pieces of pictures: the only folder, beside the pictures of each kind of scene, that knows matplotlib."""

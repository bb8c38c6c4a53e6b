"""A page to explore a study (`vibropipe view`): map, slices, motions, "what if". Needs Bokeh, the extra `view`."""

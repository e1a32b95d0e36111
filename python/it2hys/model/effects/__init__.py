"""The physics of the effects, a module each; see `it2hys.model.effect`."""

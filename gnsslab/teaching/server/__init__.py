"""The course's server: the door, the site, and the workers of a class."""

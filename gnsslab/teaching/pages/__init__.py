"""The course's own pages: home, notation, glossary, data."""

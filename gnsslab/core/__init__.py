"""Mathematics: knows no satellite."""

"""The papers' tables and stated figures against ours: one module a paper, one rule for all verdicts, one report."""

"""Twins: each target's own film formula, written again, so that its error can be told without the target."""

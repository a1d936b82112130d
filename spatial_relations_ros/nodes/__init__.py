"""The nodes: parameters in, one call, messages out."""

"""How well relations generalise to other objects: cases, variants, judged outcomes, reports."""

"""One run on a controller: the loop, what it watches, and what it hands over."""

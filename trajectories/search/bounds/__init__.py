"""What a search must keep: states come in, margins and their slopes go out."""

"""The five experiments over many seeds and recordings, and the search for gains."""

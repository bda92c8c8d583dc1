"""The only door to Universal File Format files: datasets 58 and 58b, read and written."""

"""Quotes: predicts from short pilots what a render will cost, and says where its noise is."""

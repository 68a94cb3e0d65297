"""One image file in, one array out, whatever decodes it."""

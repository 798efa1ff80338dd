"""Independent re-statements of published models, used only to check hydrocrane against them."""

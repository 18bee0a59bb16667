"""Front ends that fill the model manager: the Python builder."""

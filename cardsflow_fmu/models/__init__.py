"""The models inside the FMUs: plain classes that run without any FMI."""

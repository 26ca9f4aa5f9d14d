"""Pages for a browser: equations as MathML, the report of the demo. They need no network."""

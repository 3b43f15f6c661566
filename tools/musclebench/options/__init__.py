"""What each tool can be told: a module a tool, read by tools/launch.py before anything is installed or built. They import
nothing but Python's own library, and of this project only what does the same."""

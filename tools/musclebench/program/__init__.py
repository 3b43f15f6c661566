"""What every command shares: its command line, disk space, output folders and digests of files."""

"""Makes the LHDL data folder (meshes/*.ply, lhdl.json) from checkouts of the two upstream repositories."""

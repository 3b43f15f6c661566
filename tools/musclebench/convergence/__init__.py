"""How many substeps a muscle needs: runs of one scene with more and more of them, compared with the finest."""

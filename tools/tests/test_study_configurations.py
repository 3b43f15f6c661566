"""What tells configurations of the study apart, and what figures and tables call them."""

import fake_registry
import fake_study
from fake_study import SURFACES
from musclebench.accuracy import configurations
from musclebench.accuracy.configurations import Configuration
from musclebench.program.registry import Backend, Parameter


def configuration(backend, parameters, threads=1):
    return configurations.configuration(fake_registry.registry().backend(backend), parameters, threads)


def test_resolved_and_asked_parameters_are_the_same_configuration():
    asked = configuration("sdf", {"cells": "128"})
    resolved = configuration("sdf", {"cells": 128, "cell_size_m": 0.0, "margin": 0.001,
                                     "structures": "/somewhere"})
    assert asked == resolved and asked.name == "sdf 128" and asked.series == "sdf cells"
    assert configuration("fcl", SURFACES) == configuration("fcl", {}) == Configuration("fcl")


def test_cubes_are_a_series_of_their_own_whatever_the_count_of_cells():
    cubes = configuration("voxel", {"cells": 32, "voxel_size_m": 0.002})
    assert cubes.series == "voxel cubes" and cubes.short == "2 mm" and cubes.cells is None
    assert cubes == configuration("voxel", {"voxel_size_m": 2e-3})
    assert cubes.fineness > configuration("voxel", {"voxel_size_m": 4e-3}).fineness


def test_adaptive_cells_are_a_series_by_the_error_that_is_wanted():
    adaptive = configuration("sdf", {"cells": 64, "cell_size_m": 0.0, "max_error_mm": 0.05})
    assert adaptive.series == "sdf adaptive" and adaptive.name == "sdf to 0.05 mm" and adaptive.cells is None
    assert adaptive == configuration("sdf", {"max_error_mm": "0.05"})
    assert adaptive.fineness > configuration("sdf", {"max_error_mm": 0.3}).fineness


def test_clearance_cache_make_a_curve_or_point_of_their_own():
    assert configuration("sdf", {"clearance_cache": "on"}) == configuration("sdf", {})
    assert configuration("sdf", {"clearance_cache": "off"}).series == "sdf cells no cache"
    assert configuration("bvh", {"clearance_cache": "off"}).name == "bvh no cache"
    assert configuration("fcl", {"query": "node_distance"}).name == "fcl node distance"


def test_names_tell_configurations_apart():
    made = [configuration(backend, truth.parameters, truth.threads)
            for backend, truth in fake_study.realistic_truths()]
    assert len({one.name for one in made}) == len(made) == len(set(made))


def test_the_radius_counts_only_where_nodes_are_spheres():
    near = configuration("fcl", {"query": "node_collide", "node_radius_m": 2e-3})
    assert near != configuration("fcl", {"query": "node_collide"}) and "2 mm" in near.name
    assert configuration("fcl", {"node_radius_m": 2e-3}).is_default


def test_a_set_of_choices_that_has_a_name_is_called_by_it():
    driven = {"query": "node_collide", "bounding_volume": "OBB", "node_radius_m": 2e-3}
    assert configuration("fcl", driven).name == "fcl as advised"
    assert configuration("fcl", driven | {"clearance_cache": "off"}).name == "fcl as advised, no cache"
    assert configuration("fcl", driven | {"node_radius_m": 5e-3}).name == "fcl OBB, node radius 5 mm, node spheres"


def test_a_flag_is_the_same_asked_as_a_word_and_told_as_a_truth():
    parameters = (Parameter("cull", "flag", "", True, "", ()),)
    backend = Backend("library", "library", parameters=parameters, study={"named": [{"text": "plain", "parameters": {"cull": False}}]})
    for told in ("false", False):
        assert configurations.configuration(backend, {"cull": told}).name == "library plain"
    assert configurations.configuration(backend, {"cull": True}).is_default

#include "backends/sdf/field_export.hpp"
#include "backends/sdf/sdf_backend.hpp"
#include "core/clearance/clearance_cache.hpp"

namespace musclebench {

std::vector<ParameterSpec> sdf_parameters() {
  return {
      parameter::integer({.name = "cells",
                          .default_value = 64,
                          .minimum = 1,
                          .maximum = 4096,
                          .role = ParameterRole::resolution,
                          .help = "cells along each axis of the bone's box (unless cell_size_m is given)"}),
      parameter::number({.name = "cell_size_m",
                         .unit = "m",
                         .default_value = 0,
                         .minimum = 0,
                         .maximum = 10,
                         .role = ParameterRole::resolution,
                         .help = "edge of cubic cells; 0: use `cells`"}),
      parameter::choice({.name = "precision",
                         .choices = {"float", "compact"},
                         .help = "stored values; compact: corners in float, the others in 16 bits of a cell"}),
      parameter::number({.name = "band_m",
                         .unit = "m",
                         .default_value = 0,
                         .minimum = 0,
                         .maximum = 10,
                         .help = "narrow band: keep the cells in the bone and this far about it; not given: keep all"}),
      parameter::number({.name = "max_error_mm",
                         .unit = "mm",
                         .default_value = 0,
                         .minimum = 0,
                         .maximum = 1000,
                         .role = ParameterRole::wanted_error,
                         .help = "adaptive cells: 99 of 100 depths up to 1/200 of the bone's diagonal are off by no "
                                 "more, deeper ones by a tenth of what lies beyond that; 0: cells of one size"}),
      parameter::number({.name = "margin",
                         .default_value = 1e-3,
                         .minimum = 1e-6,
                         .maximum = 1,
                         .help = "how far the field reaches beyond the bone's box, as a share of its diagonal"}),
      parameter::path({.name = "structures",
                       .role = ParameterRole::storage,
                       .help = "folder where built fields are kept and found again by their content, by any "
                               "number of runs; empty: none"}),
      parameter::path({.name = "discregrid",
                       .help = "folder with a field BONE.cdf (Discregrid's format) for each bone, used in place of "
                               "building; empty: none"}),
      clearance_cache_parameter(),
  };
}

BackendEntry sdf_entry() {
  return {.name = "sdf",
          .help = "cubic signed distance field over each bone (the Discregrid method)",
          .implementation = "this project, after Discregrid's method (Koschier and others 2017)",
          .default_response = ResponseKind::project,
          .parameters = sdf_parameters(),
          .make = make_sdf_backend,
          .structure_export = field_export()};
}

}  // namespace musclebench

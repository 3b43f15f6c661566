#include "backends/sdf/field_export.hpp"
#include "backends/sdf/field_queries.hpp"
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
                          .help = "cells along each axis of the bone's bounding box (unless cell_size_m is given)"}),
      parameter::number({.name = "cell_size_m",
                         .unit = "m",
                         .default_value = 0,
                         .minimum = 0,
                         .maximum = 10,
                         .role = ParameterRole::resolution,
                         .help = "edge length of cubic cells; 0: use `cells`"}),
      parameter::number({.name = "max_error_mm",
                         .unit = "mm",
                         .default_value = 0,
                         .minimum = 0,
                         .maximum = 1000,
                         .role = ParameterRole::wanted_error,
                         .help =
                             "wanted error of adaptive cells: 99 of 100 depths up to 1/200 of the bone's diagonal are "
                             "within it. Deeper nodes may be off by a tenth of their further depth. 0: cells of "
                             "one size"}),
      parameter::number({.name = "margin",
                         .default_value = 1e-3,
                         .minimum = 1e-6,
                         .maximum = 1,
                         .help = "how far the field reaches beyond the bone's box, as a share of its diagonal"}),
      parameter::path({.name = "structures",
                       .role = ParameterRole::storage,
                       .help = "folder in which runs store built fields and find fields of the same content; empty: "
                               "none"}),
      parameter::path({.name = "discregrid",
                       .help = "folder with a field BONE.cdf (Discregrid's format) for each bone; the backend reads "
                               "these fields instead of building them; empty: none"}),
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
          .make_surface_queries = make_field_queries,
          .structure_export = field_export()};
}

}  // namespace musclebench

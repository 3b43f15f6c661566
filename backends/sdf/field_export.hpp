#pragma once

#include "core/contact/backend_entry.hpp"

namespace musclebench {

/// One bone's field as a file of its own: `.field` or `.cdf` (Discregrid's format) of a grid, `.octree` of an octree.
StructureExport field_export();

}  // namespace musclebench

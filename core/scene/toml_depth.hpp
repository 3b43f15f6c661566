#pragma once

#include <string>
#include <string_view>

namespace musclebench {

/// Throws InputError with file and line for a key of more dotted parts than any scene needs. toml++ bounds the nesting
/// of values but recurses over the parts of a key, so that a long key overflows the stack.
void require_shallow_keys(std::string_view text, const std::string& file);

}  // namespace musclebench

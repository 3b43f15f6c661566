#include "backends/sdf/files/kept_fields.hpp"

#include <fstream>
#include <ostream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/atomic_file.hpp"

namespace musclebench {

namespace {

std::filesystem::path note_of(std::filesystem::path field) { return field += ".json"; }

}  // namespace

std::string content_address(const std::string& built_with, const std::string& surface_digest,
                            const std::string& extension) {
  // The whole digest stands in the file, and is compared.
  constexpr std::size_t enough_digits = 16;
  return fmt::format("{}-{}.{}", built_with, surface_digest.substr(0, enough_digits), extension);
}

void note_build(const std::filesystem::path& field, Nanoseconds build_ns, int threads) {
  write_atomically(note_of(field), [&](std::ostream& out) {
    out << nlohmann::ordered_json{{"build_ns", build_ns}, {"threads", threads}}.dump() << '\n';
  });
}

std::optional<Nanoseconds> noted_build_ns(const std::filesystem::path& field) {
  std::ifstream in(note_of(field));
  const nlohmann::json note = nlohmann::json::parse(in, nullptr, false);
  if (!note.is_object() || !note.contains("build_ns") || !note["build_ns"].is_number_unsigned()) return std::nullopt;
  return note["build_ns"].get<Nanoseconds>();
}

}  // namespace musclebench

#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "backends/sdf/files/field_file.hpp"
#include "core/contact/structure_origin.hpp"

namespace musclebench {

/// Name of a field's file: what it was built with, and of which surface. Whoever builds the same from the same surface,
/// in whatever scene and under whatever name, finds it.
std::string content_address(const std::string& built_with, const std::string& surface_digest,
                            const std::string& extension);

/// Notes beside `field` what building it took, in ns, on so many threads. Throws InputError (about the path).
void note_build(const std::filesystem::path& field, Nanoseconds build_ns, int threads);

/// What `note_build` noted; nothing where no such note can be read: it is not needed to answer.
std::optional<Nanoseconds> noted_build_ns(const std::filesystem::path& field);

/// A folder in which fields are kept and found again by their content; any number of processes may share it.
template <typename Field>
struct KeptFields {
  std::function<Field()> build;
  std::function<std::optional<Field>(const std::filesystem::path&, const std::string& digest)> load;
  std::function<void(const Field&, const std::filesystem::path&, const std::string& digest)> save;

  struct Found {
    Field field;
    StructureOrigin origin;
  };

  /// Only builds it without a folder. Throws InputError (about the path) where a file there is not what it should be.
  [[nodiscard]] Found load_or_build(const std::filesystem::path& folder, const std::string& built_with,
                                    const std::string& extension, const RepairedMesh& surface, int threads) const {
    if (folder.empty()) return {build(), {}};
    const std::string digest = surface_digest(surface);
    const std::filesystem::path path = folder / content_address(built_with, digest, extension);
    if (std::optional<Field> loaded = load(path, digest)) return {*std::move(loaded), {true, noted_build_ns(path)}};
    const Nanoseconds start_ns = monotonic_now_ns();
    Field built = build();
    // Noted first, so that a field that is found has its note.
    note_build(path, monotonic_now_ns() - start_ns, threads);
    save(built, path, digest);
    return {std::move(built), {}};
  }
};

}  // namespace musclebench

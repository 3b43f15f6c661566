#include "bench/results/result_folder.hpp"

#include <algorithm>
#include <fstream>
#include <set>
#include <unistd.h>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/input_error.hpp"

namespace musclebench {

namespace {

using AnyJson = nlohmann::json;
namespace fs = std::filesystem;

/// Makes the missing folders of a path, and removes those again that it made and that are still empty, unless told to
/// keep them.
class MissingFolders {
 public:
  explicit MissingFolders(const fs::path& folder) {
    for (fs::path path = folder; !fs::exists(path); path = path.parent_path()) {
      m_made.push_back(path);
    }
    fs::create_directories(folder);
  }
  MissingFolders(const MissingFolders&) = delete;
  MissingFolders& operator=(const MissingFolders&) = delete;
  ~MissingFolders() {
    for (const fs::path& folder : m_made) {  // innermost first; another process may use the outer ones by now
      std::error_code ignored;
      fs::remove(folder, ignored);
    }
  }
  void keep() { m_made.clear(); }

 private:
  std::vector<fs::path> m_made;
};

/// A folder that goes with all that is in it, unless it was given another name before.
class PartFolder {
 public:
  explicit PartFolder(fs::path folder) : m_folder(std::move(folder)) { fs::create_directory(m_folder); }
  PartFolder(const PartFolder&) = delete;
  PartFolder& operator=(const PartFolder&) = delete;
  ~PartFolder() {
    std::error_code ignored;
    fs::remove_all(m_folder, ignored);
  }

 private:
  fs::path m_folder;
};

/// Absolute, without links and without a slash at its end.
fs::path resolved(const fs::path& folder) {
  const fs::path canonical = fs::weakly_canonical(fs::absolute(folder));
  return canonical.has_filename() ? canonical : canonical.parent_path();
}

fs::path beside(const fs::path& folder, std::string_view ending) {
  return folder.parent_path() / fmt::format(".{}.{}.{}", folder.filename().string(), getpid(), ending);
}

AnyJson read_manifest(const fs::path& folder) {
  std::ifstream file(folder / "run.json");
  return AnyJson::parse(file, nullptr, false);
}

bool is_text(const AnyJson& manifest, const char* key) {
  return manifest.is_object() && manifest.contains(key) && manifest[key].is_string();
}

/// A folder is replaced only when it is empty or holds a run and nothing else.
void require_replaceable(const fs::path& folder) {
  if (!fs::exists(folder)) {
    return;
  }
  if (!fs::is_directory(folder)) {
    throw InputError(folder.string(), "is a file; choose another --out");
  }
  const fs::path current = fs::current_path();
  if (current == folder || current.string().starts_with(folder.string() + "/")) {
    throw InputError(folder.string(), "holds the current folder and can't be replaced; choose another --out");
  }
  static const std::set<std::string> of_a_run = {"run.json",  "frames.csv", "muscles.csv", "pairs.csv",
                                                 "probe.csv", "snapshots",  "meshes",      "case.json"};
  const bool foreign = std::any_of(fs::directory_iterator(folder), fs::directory_iterator(), [](const auto& entry) {
    return of_a_run.count(entry.path().filename().string()) == 0;
  });
  if (foreign || (!fs::is_empty(folder) && !is_text(read_manifest(folder), "run_id"))) {
    throw InputError(folder.string(), "holds something else than a run and would be replaced; choose another --out");
  }
}

}  // namespace

bool is_complete(const fs::path& folder, const std::string& id, std::string_view rows_file) {
  const AnyJson manifest = read_manifest(folder);
  return is_text(manifest, "run_id") && manifest["run_id"] == id && is_text(manifest, "status") &&
         (manifest["status"] == "ok" || manifest["status"] == "suspect") && fs::exists(folder / rows_file);
}

void require_writable(const fs::path& folder) {
  try {
    const fs::path target = resolved(folder);
    require_replaceable(target);
    const MissingFolders probe(beside(target, "part"));
  } catch (const fs::filesystem_error& failure) {
    throw InputError(folder.string(),
                     fmt::format("cannot be written ({}); choose another --out", failure.code().message()));
  }
}

void write_result_folder(const fs::path& folder, const std::function<void(const fs::path&)>& write_files) {
  try {
    const fs::path target = resolved(folder);
    MissingFolders parents(target.parent_path());
    const fs::path part = beside(target, "part");
    const PartFolder part_folder(part);
    write_files(part);
    require_replaceable(target);
    // The old result stays until the new one is in its place.
    const fs::path old = beside(target, "old");
    const bool replaces = fs::exists(target);
    if (replaces) {
      fs::rename(target, old);
    }
    std::error_code failure;
    fs::rename(part, target, failure);
    if (failure) {
      if (replaces) {
        fs::rename(old, target);
      }
      throw fs::filesystem_error("rename", part, target, failure);
    }
    fs::remove_all(old);
    parents.keep();
  } catch (const fs::filesystem_error& failure) {
    throw InputError(folder.string(), fmt::format("cannot be written ({})", failure.code().message()));
  }
}

}  // namespace musclebench

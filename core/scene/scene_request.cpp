#include "core/scene/scene_request.hpp"

#include "core/base/input_error.hpp"

namespace musclebench {

SceneReference resolve_reference(const SceneRequest& request, const std::string& text, const std::string& location) {
  const std::size_t hash = text.find('#');
  SceneReference reference{text.substr(0, hash), hash == std::string::npos ? "" : text.substr(hash + 1)};
  static const std::string data_prefix = "${data}/";
  const std::string path = reference.path.string();
  if (path.starts_with(data_prefix)) {
    if (!request.data_folder) {
      throw InputError(location, "needs the anatomical data: pass --data DIR or set MUSCLEBENCH_DATA (see the README)");
    }
    reference.path = *request.data_folder / path.substr(data_prefix.size());
  } else if (reference.path.is_relative()) {
    reference.path = request.folder / reference.path;
  }
  return reference;
}

}  // namespace musclebench

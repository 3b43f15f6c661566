#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace musclebench {

/// SHA-256 of the bytes fed to it, as 64 lower-case hexadecimal digits.
class Sha256 {
 public:
  Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;
  ~Sha256();

  void add(std::span<const std::byte> bytes);
  void add(std::string_view text) { add(std::as_bytes(std::span(text))); }
  /// Ends the hash; nothing may be added afterwards.
  [[nodiscard]] std::string hex_digest();

 private:
  void* m_context;
};

}  // namespace musclebench

#include "core/base/sha256.hpp"

#include <array>
#include <openssl/evp.h>
#include <stdexcept>

namespace musclebench {

namespace {

EVP_MD_CTX* context_of(void* context) { return static_cast<EVP_MD_CTX*>(context); }

}  // namespace

Sha256::Sha256() : m_context(EVP_MD_CTX_new()) {
  if (m_context == nullptr || EVP_DigestInit_ex(context_of(m_context), EVP_sha256(), nullptr) != 1) {
    EVP_MD_CTX_free(context_of(m_context));
    throw std::runtime_error("SHA-256 is not available in this OpenSSL");
  }
}

Sha256::~Sha256() { EVP_MD_CTX_free(context_of(m_context)); }

void Sha256::add(std::span<const std::byte> bytes) {
  EVP_DigestUpdate(context_of(m_context), bytes.data(), bytes.size());
}

std::string Sha256::hex_digest() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int length = 0;
  EVP_DigestFinal_ex(context_of(m_context), digest.data(), &length);
  static constexpr char digits[] = "0123456789abcdef";
  std::string hex;
  for (unsigned int i = 0; i < length; ++i) {
    hex += digits[digest[i] >> 4U];
    hex += digits[digest[i] & 15U];
  }
  return hex;
}

}  // namespace musclebench

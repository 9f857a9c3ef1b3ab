#include "core/support/spelling.h"

#include <utf8proc.h>

#include <cstdlib>
#include <memory>
#include <system_error>

#include "core/support/error.h"

namespace burin {
namespace {

namespace fs = std::filesystem;

// Empty where the bytes are not UTF-8.
std::string Mapped(const std::string& name, int options) {
  utf8proc_uint8_t* mapped = nullptr;
  const utf8proc_ssize_t length = utf8proc_map(
      reinterpret_cast<const utf8proc_uint8_t*>(name.data()),
      static_cast<utf8proc_ssize_t>(name.size()), &mapped, static_cast<utf8proc_option_t>(options));
  const std::unique_ptr<utf8proc_uint8_t, decltype(&std::free)> owner(mapped, &std::free);
  if (length < 0) return {};
  return {reinterpret_cast<const char*>(mapped), static_cast<std::size_t>(length)};
}

std::string FromLatin1(const std::string& name) {
  std::string utf8;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80) {
      utf8.push_back(c);
    } else {
      utf8.push_back(static_cast<char>(0xC0 | (byte >> 6)));
      utf8.push_back(static_cast<char>(0x80 | (byte & 0x3F)));
    }
  }
  return utf8;
}

std::string Composed(const std::string& name, int more) {
  const int options = UTF8PROC_STABLE | UTF8PROC_COMPOSE | more;
  const std::string mapped = Mapped(name, options);
  return mapped.empty() ? Mapped(FromLatin1(name), options) : mapped;
}

}  // namespace

std::string InUtf8(const std::string& name) { return Composed(name, 0); }

std::string SpellingKey(const std::string& name) { return Composed(name, UTF8PROC_CASEFOLD); }

fs::path AsSpelled(const fs::path& path) {
  std::error_code error;
  if (path.filename().empty() || fs::exists(path, error)) return path;
  const std::string key = SpellingKey(path.filename().string());
  const fs::path folder = path.has_parent_path() ? path.parent_path() : ".";
  fs::path found;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (SpellingKey(it->path().filename().string()) != key) continue;
    if (!found.empty()) {
      throw InputError(path, "file is missing; " + found.filename().string() + " and " +
                                 it->path().filename().string() + " are both spelled like it");
    }
    found = it->path();
  }
  return found.empty() ? path : found;
}

}  // namespace burin

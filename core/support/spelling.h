// Names of files that different systems spell differently: letters with accents as one character or as two (NFC, NFD),
// in UTF-8 or in Latin-1, extensions in capitals.
#pragma once

#include <filesystem>
#include <string>

namespace burin {

// The name in UTF-8, with composed characters (NFC). Bytes that are not UTF-8 are taken as Latin-1.
std::string InUtf8(const std::string& name);

// The same for all spellings of one name: InUtf8, without regard to case.
std::string SpellingKey(const std::string& name);

// `path` where it exists; else the one file beside it whose name is another spelling of its name; else `path`. Throws
// InputError where several are.
std::filesystem::path AsSpelled(const std::filesystem::path& path);

}  // namespace burin

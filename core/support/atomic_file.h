// Output files appear whole or not at all: they are written under a temporary name in the target's
// folder and renamed over the target when complete.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace burin {

// Makes a folder, with its parents, where it does not exist. Throws InputError when it cannot be made.
void MakeFolder(const std::filesystem::path& folder);

// Calls write(temporary_path), whose file name keeps the target's extension, then renames it to
// `target`. When write throws, the temporary file is removed and the target is left as it was.
// Throws InputError when the folder does not exist or cannot be written.
void WriteAtomically(const std::filesystem::path& target,
                     const std::function<void(const std::filesystem::path& temporary)>& write);

// The same for text that is at hand.
void WriteTextAtomically(const std::filesystem::path& target, const std::string& text);

// The same, on the disk when it returns, so that it outlasts a power cut.
void WriteTextDurably(const std::filesystem::path& target, const std::string& text);

// Removes what a process that was killed while it wrote has left in `folder`.
void RemoveTemporaries(const std::filesystem::path& folder);

}  // namespace burin

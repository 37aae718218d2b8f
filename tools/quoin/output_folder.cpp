#include "output_folder.hpp"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "hash.hpp"
#include "scene_file/scene_error.hpp"

namespace quoin::commands {
namespace {

namespace fs = std::filesystem;
using scene_file::FileError;

constexpr const char* kJournal = ".quoin-journal";
constexpr const char* kManifest = "manifest.json";
constexpr const char* kPart = ".part-";

[[noreturn]] void refuse(const fs::path& path, const std::string& why) {
  throw FileError(path.string() + ": " + why);
}

/// Calls `act`; what the file system says becomes a FileError about `path`.
template <class Act>
auto guarded(const fs::path& path, const Act& act) {
  try {
    return act();
  } catch (const fs::filesystem_error& error) {
    refuse(path, "can't be written: " + error.code().message());
  }
}

bool is_plain_file(const fs::path& path) {
  std::error_code none;
  return fs::is_regular_file(fs::symlink_status(path, none));
}

/// Of the first and the last 64 KiB: a file that somebody has edited is told from ours, and results
/// of many gigabytes cost no time.
std::string hash_of_ends(const fs::path& path, std::uintmax_t size) {
  constexpr std::uintmax_t kEnd = 65536;
  std::vector<char> bytes(kEnd);
  std::ifstream in(path, std::ios::binary);
  std::uint64_t hash = kHashOfNothing;
  const auto take = [&](std::uintmax_t from) {
    in.clear();
    in.seekg(static_cast<std::streamoff>(from));
    in.read(bytes.data(), static_cast<std::streamsize>(kEnd));
    hash = hashed({bytes.data(), static_cast<std::size_t>(in.gcount())}, hash);
  };
  take(0);
  if (size > kEnd) take(std::max(kEnd, size - kEnd));
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

struct Entry {
  std::uintmax_t size = 0;
  std::string hash{};
  bool operator==(const Entry&) const = default;
};

Entry entry_of(const fs::path& path) {
  const std::uintmax_t size = fs::file_size(path);
  return {size, hash_of_ends(path, size)};
}

/// What the manifest of a folder names; empty when there is none.
std::map<std::string, Entry> read_manifest(const fs::path& folder) {
  std::map<std::string, Entry> entries;
  if (!is_plain_file(folder / kManifest)) return entries;
  std::ifstream in(folder / kManifest);
  try {
    const nlohmann::json manifest = nlohmann::json::parse(in);
    for (const auto& [name, entry] : manifest.at("files").items())
      entries[name] = {entry.at("size"), entry.at("hash")};
  } catch (const nlohmann::json::exception&) {
    refuse(folder / kManifest, "is no manifest that quoin wrote");
  }
  return entries;
}

/// The first file of a folder that quoin did not write, and why it is none of ours.
std::optional<FileError> foreign_file(const fs::path& folder) {
  const std::map<std::string, Entry> ours = read_manifest(folder);
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (is_plain_file(entry.path())) {
      if (name == kManifest || name == kJournal) continue;
      const auto known = ours.find(name);
      if (known != ours.end()) {
        if (known->second == entry_of(entry.path())) continue;
        return FileError(entry.path().string() +
                         ": was changed since quoin wrote it; the folder is not replaced");
      }
    }
    return FileError(entry.path().string() +
                     ": quoin did not write it; the folder is not replaced");
  }
  return std::nullopt;
}

void check_replaceable(const fs::path& folder) {
  const fs::file_status status = fs::status(folder);
  if (!fs::exists(status)) return;
  if (!fs::is_directory(status)) refuse(folder, "is there already and is no folder");
  struct stat own {
  }, above{};
  if (::stat(folder.c_str(), &own) == 0 && ::stat(folder.parent_path().c_str(), &above) == 0 &&
      (own.st_dev != above.st_dev || own.st_ino == above.st_ino))
    refuse(folder, "is the top of a file system and can't be replaced; name a folder in it");
  if (const std::optional<FileError> error = foreign_file(folder)) throw FileError(*error);
}

/// The folder itself: absolute, where a link points to, without a trailing slash.
fs::path resolved(const fs::path& folder) {
  fs::path path = fs::absolute(folder).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  if (fs::is_symlink(fs::symlink_status(path)) && !fs::exists(path))
    refuse(path, "is a link to nothing");
  return fs::exists(path) ? fs::canonical(path) : path;
}

/// What a killed run was writing when it was killed, before it was resumed.
void remove_half_written(const fs::path& part, const std::vector<std::string>& names) {
  for (const std::string& name : names) ::unlink((part / (name + ".part")).c_str());
}

void remove_listed(const fs::path& folder, const std::vector<std::string>& names) {
  std::error_code ignored;
  for (const std::string& name : names) {
    if (name.find('/') != std::string::npos) continue;
    for (const char* ending : {"", ".part"})
      if (is_plain_file(folder / (name + ending))) fs::remove(folder / (name + ending), ignored);
  }
}

/// Removes the folder with what is listed; one that holds anything else stays, with that.
void remove_ours(const fs::path& folder, std::vector<std::string> names) {
  names.insert(names.end(), {kManifest, kJournal});
  remove_listed(folder, names);
  ::rmdir(folder.c_str());
}

std::vector<std::string> read_journal(const fs::path& part) {
  std::vector<std::string> names;
  std::ifstream in(part / kJournal);
  for (std::string name; std::getline(in, name);) names.push_back(name);
  return names;
}

bool is_part_of(const std::string& name, const fs::path& folder) {
  return name.starts_with(folder.filename().string() + kPart);
}

/// The journal of a part folder, locked; -1 while its run lives (or nobody can tell).
int lock_of_dead_run(const fs::path& part) {
  if (!fs::is_directory(fs::symlink_status(part)) || !is_plain_file(part / kJournal)) return -1;
  const int file = ::open((part / kJournal).c_str(), O_RDWR | O_APPEND | O_CLOEXEC | O_NOFOLLOW);
  if (file >= 0 && ::flock(file, LOCK_EX | LOCK_NB) != 0) {
    ::close(file);
    return -1;
  }
  return file;
}

/// Part folders of this name beside it.
std::vector<fs::path> parts_of(const fs::path& folder) {
  std::vector<fs::path> parts;
  if (!fs::exists(folder.parent_path())) return parts;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder.parent_path()))
    if (is_part_of(entry.path().filename().string(), folder)) parts.push_back(entry.path());
  return parts;
}

/// While it lives no other run makes a part folder in `folder`, or sweeps there.
class FolderLock {
 public:
  explicit FolderLock(const fs::path& folder)
      : file_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)),
        holds_(file_ >= 0 && ::flock(file_, LOCK_EX) == 0) {}
  ~FolderLock() {
    if (file_ >= 0) ::close(file_);
  }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  bool holds() const { return holds_; }

 private:
  int file_;
  bool holds_;
};

/// A run that was killed right after it had made its part folder.
bool is_left_empty(const fs::path& part) {
  return !fs::is_symlink(part) && fs::is_directory(part) && fs::is_empty(part);
}

/// What killed runs left: removed, unless there is a checkpoint to go on from.
void sweep(const fs::path& folder, const FolderLock& lock) {
  for (const fs::path& part : parts_of(folder)) {
    if (lock.holds() && is_left_empty(part)) {
      fs::remove(part);
      continue;
    }
    const int journal = lock_of_dead_run(part);
    if (journal < 0) continue;
    if (fs::exists(part / OutputFolder::kCheckpoint)) {
      std::fprintf(stderr, "quoin: %s: a killed run left a checkpoint; it is kept (--resume)\n",
                   part.c_str());
    } else {
      remove_ours(part, read_journal(part));
    }
    ::close(journal);
  }
}

/// Results that are about to be replaced look like those of a dead run without a checkpoint: a kill
/// before they are removed leaves them to the next sweep.
void mark_as_left(const fs::path& folder, const std::vector<std::string>& names) {
  std::ofstream journal(folder / kJournal);
  for (const std::string& name : names) journal << name << '\n';
  journal.close();
  if (!journal) throw scene_file::unwritable((folder / kJournal).string());
  ::unlink((folder / OutputFolder::kCheckpoint).c_str());
}

fs::path new_part(const fs::path& folder) {
  std::string name = folder.string() + kPart + "XXXXXX";
  if (::mkdtemp(name.data()) == nullptr) throw scene_file::unwritable(folder.string());
  const mode_t mask = ::umask(0);
  ::umask(mask);
  ::chmod(name.c_str(), 0777 & ~mask);  // as any new folder, not for its owner alone
  return name;
}

void write_manifest(const fs::path& part, const std::vector<std::string>& names) {
  nlohmann::ordered_json files = nlohmann::ordered_json::object();
  for (const std::string& name : names) {
    if (!is_plain_file(part / name)) continue;
    const Entry entry = entry_of(part / name);
    files[name] = {{"size", entry.size}, {"hash", entry.hash}};
  }
  std::ofstream out(part / kManifest);
  out << nlohmann::ordered_json{{"quoin", QUOIN_VERSION}, {"files", files}}.dump(1) << '\n';
  out.close();
  if (!out) throw scene_file::unwritable((part / kManifest).string());
}

}  // namespace

OutputFolder::OutputFolder(const fs::path& folder) {
  guarded(folder, [&] {
    folder_ = resolved(folder);
    check_replaceable(folder_);
    fs::create_directories(folder_.parent_path());
    const FolderLock lock(folder_.parent_path());
    sweep(folder_, lock);
    part_ = new_part(folder_);
    lock_journal(O_CREAT | O_EXCL);
  });
}

OutputFolder::OutputFolder(OutputFolder&& other) noexcept
    : folder_(std::move(other.folder_)),
      part_(std::move(other.part_)),
      names_(std::move(other.names_)),
      copied_(other.copied_),
      journal_(std::exchange(other.journal_, -1)) {}

OutputFolder::~OutputFolder() {
  if (journal_ < 0) return;
  if (names_.empty() || copied_) remove_ours(part_, names_);  // nothing was written
  ::close(journal_);
}

void OutputFolder::lock_journal(int flags) {
  const fs::path path = part_ / kJournal;
  journal_ = ::open(path.c_str(), O_RDWR | O_APPEND | O_CLOEXEC | flags, 0666);
  if (journal_ < 0) throw scene_file::unwritable(path.string());
  ::flock(journal_, LOCK_EX | LOCK_NB);
}

OutputFolder OutputFolder::reopen(const fs::path& folder) {
  OutputFolder result;
  guarded(folder, [&] {
    const fs::path named = resolved(folder);
    const std::string name = named.filename().string();
    const std::size_t at = name.rfind(kPart);
    const bool is_part = at != std::string::npos && fs::exists(named / kJournal);
    result.folder_ = is_part ? named.parent_path() / name.substr(0, at) : named;
    std::vector<fs::path> parts = is_part ? std::vector<fs::path>{named} : parts_of(named);
    std::erase_if(parts, [](const fs::path& p) {
      return !fs::exists(p / kCheckpoint) || !fs::exists(p / kJournal);
    });
    std::sort(parts.begin(), parts.end(), [](const fs::path& a, const fs::path& b) {
      return fs::last_write_time(a / kCheckpoint) < fs::last_write_time(b / kCheckpoint);
    });
    if (!parts.empty()) {
      result.part_ = parts.back();
      result.journal_ = lock_of_dead_run(result.part_);
      if (result.journal_ < 0) refuse(result.part_, "its run has not ended");
      result.names_ = read_journal(result.part_);
      return;
    }
    if (!fs::exists(named))
      refuse(named, "there is no such folder, and no checkpoint to go on from");
    if (!is_plain_file(named / kCheckpoint))
      refuse(named, is_plain_file(named / kManifest)
                        ? "its run has ended, there is no checkpoint to go on from"
                        : "there is no checkpoint to go on from");
    const std::map<std::string, Entry> ours = read_manifest(named);
    check_replaceable(named);
    {
      const FolderLock lock(named.parent_path());
      result.part_ = new_part(named);
      result.lock_journal(O_CREAT | O_EXCL);
    }
    for (const auto& [file, entry] : ours) {
      if (file == kJournal || file == kCheckpoint || !fs::exists(named / file)) continue;
      fs::copy_file(named / file, result.file(file));
    }
    // Last and at once: a part that has it is whole.
    const fs::path checkpoint = result.file(kCheckpoint);
    fs::copy_file(named / kCheckpoint, checkpoint.string() + ".part");
    fs::rename(checkpoint.string() + ".part", checkpoint);
    result.copied_ = true;
  });
  sweep(result.folder_, FolderLock(result.folder_.parent_path()));
  return result;
}

OutputFolder OutputFolder::of_another(const fs::path& part) {
  OutputFolder result;
  result.part_ = part;
  return result;
}

fs::path OutputFolder::file(const std::string& name) {
  if (journal_ < 0) return part_ / name;
  copied_ = false;
  if (std::find(names_.begin(), names_.end(), name) == names_.end()) {
    const std::string line = name + "\n";
    if (::write(journal_, line.data(), line.size()) != std::ssize(line))
      throw scene_file::unwritable((part_ / kJournal).string());
    names_.push_back(name);
  }
  return part_ / name;
}

void OutputFolder::commit(Checkpoint checkpoint) {
  remove_half_written(part_, names_);
  write_manifest(part_, names_);
  guarded(folder_, [&] {
    try {
      check_replaceable(folder_);
    } catch (const FileError& error) {
      throw FileError(std::string(error.what()) + "; the results are in " + part_.string());
    }
    if (!fs::exists(folder_)) {
      fs::rename(part_, folder_);
    } else {
      std::vector<std::string> old;
      for (const auto& [name, entry] : read_manifest(folder_)) old.push_back(name);
      mark_as_left(folder_, old);
      if (::renameat2(AT_FDCWD, part_.c_str(), AT_FDCWD, folder_.c_str(), RENAME_EXCHANGE) != 0)
        throw fs::filesystem_error("", std::error_code(errno, std::generic_category()));
      remove_ours(part_, old);
    }
  });
  ::unlink((folder_ / kJournal).c_str());
  if (checkpoint == Checkpoint::Drop) ::unlink((folder_ / kCheckpoint).c_str());
  ::close(std::exchange(journal_, -1));
}

}  // namespace quoin::commands

// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Power cuts: every state the disk may be in when what was not synced is kept, lost, torn or out
// of order. After recovery each must be a valid dive with every image that was acknowledged.
#include <gtest/gtest.h>
#include <unistd.h>

#include <random>
#include <set>

#include "nadir/core/check.hpp"
#include "nadir/record/recover.hpp"
#include "record/fake_disk.hpp"
#include "record/small_dive.hpp"

namespace nadir::record {
namespace {

using nlohmann::json;

/// The files of a folder by their relative names.
using Files = std::map<std::string, std::string>;
/// How much of an operation that was not synced reached the disk: 0 none, 1 all.
using Kept = std::map<std::size_t, double>;

std::string folder_of(const std::string& name) { return path(name).parent_path().string(); }

bool is_of_data(const Operation& op) {
  return op.kind == Operation::write || op.kind == Operation::truncate;
}
bool is_sync(const Operation& op) { return op.kind >= Operation::sync_file; }

bool makes_durable(const Operation& sync, const Operation& op) {
  if (sync.kind == Operation::sync_all) return true;
  if (is_of_data(op)) return sync.kind == Operation::sync_file && sync.inode == op.inode;
  return sync.kind == Operation::sync_folder && sync.name == folder_of(op.name);
}

// Of the first `end` operations: those that a power cut may undo.
std::vector<std::size_t> pending(const std::vector<Operation>& ops, std::size_t end) {
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < end; ++i) {
    if (is_sync(ops[i])) {
      std::erase_if(open, [&](std::size_t earlier) { return makes_durable(ops[i], ops[earlier]); });
    } else {
      open.push_back(i);
    }
  }
  return open;
}

class CrashedDisk {
 public:
  CrashedDisk(const Files& before, const std::map<std::string, int>& inodes) {
    for (const auto& [name, inode] : inodes) {
      names_[name] = inode;
      data_[inode] = before.at(name);
    }
  }

  void apply(const Operation& op, double kept) {
    if (kept == 0) return;
    switch (op.kind) {
      case Operation::create:
        names_[op.name] = op.inode;
        break;
      case Operation::write:
        write(data_[op.inode], op, static_cast<std::size_t>(kept * double(op.other.size())));
        break;
      case Operation::truncate:
        data_[op.inode].clear();
        break;
      case Operation::rename:
        if (const auto from = names_.extract(op.name)) names_[op.other] = from.mapped();
        break;
      case Operation::remove:
        names_.erase(op.name);
        break;
      case Operation::folder:
        folders_.insert(op.name);
        break;
      default:
        break;
    }
  }

  /// What lies under the root; a file whose folder was lost is lost.
  Files files(const std::string& root) {
    Files files;
    for (const auto& [name, inode] : names_) {
      const std::string relative = name.substr(root.size() + 1);
      const bool top = relative.find('/') == std::string::npos;
      if (top || folders_.empty() || folders_.contains(folder_of(name))) {
        files[relative] = data_[inode];
      }
    }
    return files;
  }

 private:
  static void write(std::string& data, const Operation& op, std::size_t size) {
    data.resize(std::max(data.size(), op.offset + size), '\0');
    data.replace(op.offset, size, op.other, 0, size);
  }

  std::map<std::string, int> names_;
  std::map<int, std::string> data_;
  std::set<std::string> folders_;
};

// All kept, none kept, each one alone lost, kept or torn, and some mixtures.
std::vector<Kept> choices(const std::vector<Operation>& ops, const std::vector<std::size_t>& open,
                          std::mt19937& random) {
  const auto all = [&](double kept) {
    Kept choice;
    for (const std::size_t i : open) choice[i] = kept;
    return choice;
  };
  std::vector<Kept> choices{all(1), all(0)};
  for (const std::size_t i : open) {
    for (const double rest : {1.0, 0.0}) {
      for (const double kept : {1 - rest, 0.5, 0.97}) {
        if (kept != 1 - rest && ops[i].kind != Operation::write) continue;
        choices.push_back(all(rest));
        choices.back()[i] = kept;
      }
    }
  }
  for (int n = 0; n < 6 && open.size() > 2; ++n) {
    choices.push_back(all(0));
    for (auto& [i, kept] : choices.back()) kept = static_cast<double>(random() % 3) / 2;
  }
  return choices;
}

struct History {
  std::string root;
  Files before;                       ///< what was there
  std::map<std::string, int> inodes;  ///< of it
  std::vector<Operation> operations;
};

/// Calls with each different state, or one in `stride` of them, and the number of operations that
/// had been done.
template <class Visit>
std::size_t for_each_crash(const History& history, std::size_t stride, Visit visit) {
  std::mt19937 random(7);
  std::size_t states = 0;
  std::set<Files> seen;
  for (std::size_t end = 0; end <= history.operations.size(); ++end) {
    if (end > 0 && end < history.operations.size() && is_sync(history.operations[end]) &&
        !is_sync(history.operations[end - 1])) {
      continue;  // a sync under way is the same as one not begun; both are seen at its other end
    }
    const auto open = pending(history.operations, end);
    for (const Kept& choice : choices(history.operations, open, random)) {
      CrashedDisk disk(history.before, history.inodes);
      for (std::size_t i = 0; i < end; ++i) {
        const auto kept = choice.find(i);
        disk.apply(history.operations[i], kept == choice.end() ? 1 : kept->second);
      }
      const Files files = disk.files(history.root);
      if (!seen.insert(files).second || seen.size() % stride != 0) continue;
      ++states;
      visit(files, end);
      if (testing::Test::HasFatalFailure()) return states;
    }
  }
  return states;
}

void lay_out(const Files& files, const path& folder) {
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder / "projected");
  std::filesystem::create_directories(folder / "mosaic2d");
  for (const auto& [name, text] : files) write_text(folder / name, text);
}

int lines_of(const std::string& text) {
  return static_cast<int>(std::ranges::count(text, '\n')) - (text.starts_with('#') ? 1 : 0);
}

// A valid dive holding at least the first `acknowledged` images, with nothing half-made about.
void expect_valid(const path& folder, const Recovery& recovery, int acknowledged,
                  const Files& finished) {
  const Files files = read_all(folder);
  ASSERT_GE(recovery.oriented, static_cast<std::uint64_t>(acknowledged));
  ASSERT_TRUE(recovery.whole());
  const json dive = json::parse(files.at("dive.json"));
  const json& counts = dive["counts"];
  ASSERT_EQ(counts["captured"], recovery.captured);
  ASSERT_EQ(recovery.captured, recovery.oriented + recovery.lost + recovery.dropped);
  ASSERT_EQ(lines_of(files.at("trajectory.tum")), static_cast<int>(recovery.oriented));
  for (const auto& [name, text] : files) {
    ASSERT_EQ(name.find("/."), std::string::npos) << name;
    ASSERT_FALSE(name.starts_with('.')) << name;
    if (name.starts_with("projected/")) {
      ASSERT_EQ(text, finished.at(name)) << name;
      const std::string image = name.substr(0, name.find('.'));
      for (const char* kind : {".png", ".pgw", ".png.aux.xml"})
        ASSERT_TRUE(files.contains(image + kind)) << name;
    }
  }
  for (int i = 0; i < acknowledged; ++i) {
    ASSERT_TRUE(files.contains("projected/00000" + std::to_string(i) + ".png")) << i;
  }
}

class PowerCut : public testing::Test {
 protected:
  PowerCut() {
    small_.with_tiles = false;
    record_dive();
  }

  // Records how many images were acknowledged when as many operations were done.
  void record_dive() {
    RecordingDisk disk;
    const path folder = scratch_ / "dive";
    {
      Dive dive(folder, small_.info(), {}, disk);
      acknowledged_[0] = -1;
      acknowledged_[disk.operations.size()] = 0;
      for (int i = 0; i < small_.images; ++i) {
        ASSERT_TRUE(dive.add(small_.entry(static_cast<std::uint64_t>(i))).empty());
        ASSERT_EQ(dive.saved(), static_cast<std::uint64_t>(i + 1));
        acknowledged_[disk.operations.size()] = i + 1;
      }
      ASSERT_TRUE(dive.finish({}).empty());
    }
    finished_ = read_all(folder);
    history_.root = folder.string();
    history_.operations = disk.operations;
  }

  int acknowledged_at(std::size_t operations) const {
    return std::prev(acknowledged_.upper_bound(operations))->second;
  }

  SmallDive small_;
  ScratchFolder scratch_;
  History history_;
  Files finished_;
  std::map<std::size_t, int> acknowledged_;  ///< -1: the dive had not begun
};

TEST_F(PowerCut, AtAnyInstantLosesNothingThatWasAcknowledged) {
  QuickDisk disk;
  const path crashed = scratch_ / "crashed";
  const std::size_t states = for_each_crash(history_, 2, [&](const Files& files, std::size_t end) {
    lay_out(files, crashed);
    const int acknowledged = acknowledged_at(end);
    try {
      expect_valid(crashed, recover(crashed, disk), std::max(acknowledged, 0), finished_);
    } catch (const InputError& error) {
      ASSERT_EQ(acknowledged, -1) << error.what();
      ASSERT_EQ(read_all(crashed), files);
    }
    if (testing::Test::HasFatalFailure()) {
      for (const auto& [name, text] : files) std::printf("  %s %zu\n", name.c_str(), text.size());
      std::printf("after %zu operations\n", end);
    }
  });
  std::printf("%zu crash states\n", states);
  EXPECT_GT(states, 500u);
}

TEST_F(PowerCut, DuringRecoveryIsRecoveredFrom) {
  // Cut in the middle of the dive, with everything un-synced lost; then again while recovering.
  const std::size_t middle = std::next(acknowledged_.begin(), 4)->first;
  CrashedDisk first({}, {});
  const auto open = pending(history_.operations, middle);
  for (std::size_t i = 0; i < middle; ++i) {
    first.apply(history_.operations[i], std::ranges::count(open, i) ? 0 : 1);
  }
  History history;
  const path folder = scratch_ / "again", crashed = scratch_ / "crashed";
  history.root = folder.string();
  lay_out(first.files(history_.root), folder);
  RecordingDisk recording;
  for (const auto& [name, text] : first.files(history_.root)) {
    const std::string whole_name = (folder / name).string();
    recording.know(whole_name);
    history.before[whole_name] = text;
    history.inodes[whole_name] = recording.inode(whole_name);
  }
  (void)recover(folder, recording);
  history.operations = recording.operations;
  QuickDisk disk;
  const std::size_t states = for_each_crash(history, 10, [&](const Files& files, std::size_t end) {
    lay_out(files, crashed);
    expect_valid(crashed, recover(crashed, disk), acknowledged_at(middle), finished_);
    if (testing::Test::HasFatalFailure()) std::printf("after %zu operations\n", end);
  });
  std::printf("%zu crash states\n", states);
  EXPECT_GT(states, 200u);
}

TEST_F(PowerCut, CostsTwoSyncsAnImage) {
  std::size_t syncs = 0;
  const auto& ops = history_.operations;
  const std::size_t begin = std::next(acknowledged_.begin(), 2)->first;  // after the first image
  const std::size_t end = std::prev(acknowledged_.end())->first;
  for (std::size_t i = begin; i < end; ++i) syncs += is_sync(ops[i]) ? 1 : 0;
  EXPECT_EQ(syncs, 2u * static_cast<std::size_t>(small_.images - 1));
}

}  // namespace
}  // namespace nadir::record

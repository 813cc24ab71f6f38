// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Files made to harm: each is refused in a line, soon, and without much memory.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <random>

#include "samples.hpp"

namespace nadir::calibration::sample {
namespace {

using ::testing::HasSubstr;

std::string repeated(const std::string& part, std::size_t count) {
  std::string text;
  text.reserve(part.size() * count);
  for (std::size_t i = 0; i < count; ++i) text += part;
  return text;
}

const std::string kSamples[] = {kKalibrMono, kKalibrPair,      kOkvisPair, kPoseGraph,
                                kOrbSlam,    kMatisse,         kRos1,      kColmap,
                                kMetashape,  kMetashapeCameras};

TEST(Hostile, NestingOfEveryKindIsRefused) {
  for (const char* part : {"[", "{", "{a: ", "[a: ", "- ", "? ", "? - ", "- - ", ": ", "[[", "{? ",
                           "[? ", "!t [", "&a [", "\"\": ["}) {
    const std::string deep = repeated(part, 100'000);
    EXPECT_NE(refusal(deep), "accepted") << part;
    EXPECT_NE(refusal("a: " + deep + "\n"), "accepted") << part;
    EXPECT_NE(refusal(kKalibrMono + "other: " + deep + "\n"), "accepted") << part;
  }
  EXPECT_THAT(refusal("a: " + repeated("[", 1000) + repeated("]", 1000) + "\n"),
              HasSubstr("nested too deep"));
  std::string block;
  for (std::size_t i = 0; i < 1000; ++i) block += std::string(i, ' ') + "a:\n";
  EXPECT_THAT(refusal(block), HasSubstr("nested too deep"));
  EXPECT_THAT(refusal(repeated("<a>", 100'000) + repeated("</a>", 100'000)),
              HasSubstr("nested too deep"));
  EXPECT_NE(refusal("<opencv_storage>" + repeated("<a>", 300'000)), "accepted");
  EXPECT_NE(refusal("<!DOCTYPE a " + repeated("<!", 300'000)), "accepted");
}

TEST(Hostile, AliasesAreNeverFollowed) {
  std::string bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 60; ++i) {
    const std::string last = std::string("*a") + std::to_string(i - 1);
    const std::string name = std::string("a") + std::to_string(i);
    bomb.append(name).append(": &").append(name).append(" [").append(last);
    for (int k = 0; k < 9; ++k) bomb += ", " + last;
    bomb += "]\n";
  }
  EXPECT_THAT(refusal(bomb), HasSubstr("image_width is missing"));
  EXPECT_EQ(load(bomb + kKalibrMono).left.fx, 416.5);  // what is not looked at does no harm
  EXPECT_THAT(refusal("size: &s [848, 480]\n" + replaced(kKalibrMono, "[848, 480]", "*s")),
              HasSubstr("cam0.resolution: is not a matrix"));
  EXPECT_THAT(refusal("w: &w 800\n" + replaced(kPoseGraph.substr(10), "width: 800", "width: *w")),
              HasSubstr("image_width: a YAML alias is not a finite number"));
  EXPECT_NE(refusal("a: &a\n  b: *a\n"), "accepted");
  EXPECT_NE(refusal("cam0:\n  <<: *missing\n"), "accepted");
}

TEST(Hostile, XmlEntitiesAreNotExpanded) {
  std::string bomb = "<!DOCTYPE calibration [<!ENTITY e0 \"1\">";
  for (int i = 1; i < 40; ++i) {
    const std::string last = std::string("&e") + std::to_string(i - 1) + ";";
    bomb.append("<!ENTITY e").append(std::to_string(i)).append(" \"");
    bomb.append(repeated(last, 10)).append("\">");
  }
  bomb += "]>" + replaced(kMetashape.substr(kMetashape.find("<cal")), "1430", "&e39;");
  EXPECT_THAT(refusal(bomb), HasSubstr("f: \"&e39;\" is not a finite number"));
}

TEST(Hostile, ManyValuesAndLargeFilesAreRefused) {
  EXPECT_THAT(refusal("a: [" + repeated("1,", 300'000) + "1]\n"), HasSubstr("too many values"));
  EXPECT_THAT(refusal("<a>" + repeated("<b/>", 200'000) + "</a>"), HasSubstr("too many values"));
  EXPECT_THAT(refusal(repeated("1 PINHOLE 9 9 1 1 1 1\n", 40'000)), HasSubstr("no image size"));
  EXPECT_THAT(refusal(replaced(kKalibrMono, "[848, 480]", "[" + repeated("848, ", 1000) + "1]")),
              HasSubstr("impossible size"));
  for (const char* start : {"%YAML:1.0\n", "<calibration>", "1 PINHOLE 968 728 "}) {
    EXPECT_THAT(refusal(start + std::string(10'000'000, ' ')), HasSubstr("larger than 1 MB"));
  }
  for (const char* part :
       {"a: b\n", "- a\n", "\"", "'",     "#", "|\n",  "!",  "&",         "*",  "%",
        "\t",     "\r",    "a:", "? a\n", "<", "<!--", "<?", "<![CDATA[", "1 ", "\xff"}) {
    const std::string much = repeated(part, (1 << 20) / std::string(part).size());
    EXPECT_NE(refusal(much), "accepted") << part;
    EXPECT_NE(refusal("a: " + much.substr(3)), "accepted") << part;
  }
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // which keep what was freed
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  EXPECT_LT(used.ru_maxrss, 400'000);  // kB
#endif
}

TEST(Hostile, KeysGivenTwiceAreRefusedInEveryFormat) {
  EXPECT_THAT(
      refusal(replaced(kKalibrMono, "  resolution", "  intrinsics: [1, 1, 1, 1]\n  resolution")),
      HasSubstr("cam0.intrinsics: is given twice; delete one"));
  EXPECT_THAT(refusal(kOrbSlam + "Camera.fx: 1\n"), HasSubstr("Camera.fx: is given twice"));
  EXPECT_THAT(refusal(replaced(kMetashape, "<f>", "<f>1</f><f>")), HasSubstr("f: is given twice"));
  EXPECT_THAT(
      refusal(replaced(kOkvisPair, "focal_length", "image_dimension: [1, 1], focal_length")),
      HasSubstr("cameras[0].image_dimension: is given twice"));
}

TEST(Hostile, DamageOfAnyKindIsSurvived) {
  std::mt19937 random(5);
  const auto at = [&](std::size_t size) { return static_cast<std::size_t>(random()) % size; };
  int accepted = 0;
  for (int i = 0; i < 5'000; ++i) {
    std::string text = kSamples[at(std::size(kSamples))];
    for (std::size_t k = 0; k <= at(4); ++k) {
      switch (at(5)) {
        case 0:
          text[at(text.size())] = static_cast<char>(random());
          break;
        case 1:
          text[at(text.size())] = "[]{}:-,!&*\"'\n <>/?=|%#"[at(22)];
          break;
        case 2:
          text.erase(at(text.size()), at(20));
          break;
        case 3: {
          const std::string other = kSamples[at(std::size(kSamples))];
          text.insert(at(text.size()), other.substr(at(other.size()), at(100)));
          break;
        }
        default:
          text.resize(1 + at(text.size()));
      }
      if (text.empty()) text.push_back(' ');
    }
    accepted += refusal(text) == "accepted" ? 1 : 0;
  }
  EXPECT_GT(accepted, 0);  // damage to digits cannot always be seen
}

}  // namespace
}  // namespace nadir::calibration::sample

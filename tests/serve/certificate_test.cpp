// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "certificate_files.hpp"
#include "nadir/core/check.hpp"
#include "nadir/serve/web_server.hpp"

namespace nadir::serve {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

Config with(const std::string& certificate, const std::string& key) {
  Config config;
  config.port = 0;
  config.certificate = certificate;
  config.key = key;
  return config;
}

std::string fault(const std::string& certificate, const std::string& key) {
  return certificate_fault(with(certificate, key));
}

TEST(Certificate, IsUsedWithItsKey) {
  const CertificateFiles elliptic, rsa(3600, CertificateFiles::Kind::rsa);
  EXPECT_EQ(fault(elliptic.certificate(), elliptic.key()), "");
  EXPECT_EQ(fault(rsa.certificate(), rsa.key()), "");
  EXPECT_EQ(certificate_fault(Config()), "") << "none is none";
}

TEST(Certificate, IsNamedWithItsKeyOrNotAtAll) {
  const auto said = [](const Config& config) -> std::string {
    try {
      config.check();
      return "";
    } catch (const InputError& error) {
      return error.what();
    }
  };
  EXPECT_THAT(said(with("a.pem", "")), StartsWith("serve.key is missing"));
  EXPECT_THAT(said(with("", "b.pem")), StartsWith("serve.certificate is missing"));
  EXPECT_THAT(said(with("", "b.pem")), HasSubstr("name both files or neither"));
  EXPECT_EQ(said(with("a.pem", "b.pem")), "");
}

TEST(Certificate, ThatIsNotThereIsTold) {
  const CertificateFiles files;
  EXPECT_THAT(fault("/nonexistent/a.pem", files.key()),
              AllOf(StartsWith("serve.certificate: /nonexistent/a.pem cannot be read: No such"),
                    HasSubstr("name a PEM file")));
  EXPECT_THAT(fault(files.certificate(), "/nonexistent/b.pem"),
              StartsWith("serve.key: /nonexistent/b.pem cannot be read: No such"));
}

TEST(Certificate, ThatIsNoneIsTold) {
  const CertificateFiles files;
  std::ofstream(files.folder / "text") << "garbage\n";
  const std::string text = files.folder / "text";
  EXPECT_THAT(fault(text, files.key()), AllOf(StartsWith("serve.certificate: " + text),
                                              HasSubstr("no usable certificate (")));
  EXPECT_THAT(fault(files.key(), files.key()), HasSubstr("no usable certificate ("));
  EXPECT_THAT(fault(files.folder, files.key()), HasSubstr("no usable certificate ("));
  EXPECT_THAT(fault(files.certificate(), text),
              AllOf(StartsWith("serve.key: " + text), HasSubstr("no usable key (")));
  EXPECT_THAT(fault(files.certificate(), files.certificate()), HasSubstr("no usable key ("));
}

TEST(Certificate, OfAnotherKeyIsTold) {
  const CertificateFiles files, other, rsa(3600, CertificateFiles::Kind::rsa);
  for (const std::string& key : {other.key(), rsa.key()}) {
    EXPECT_EQ(fault(files.certificate(), key),
              "serve.key: " + key + " does not fit the certificate " + files.certificate() +
                  "; give the key that it was made with");
  }
}

TEST(Certificate, WhoseKeyHasAPassphraseIsToldWithoutAskingForIt) {
  const CertificateFiles files(3600, CertificateFiles::Kind::elliptic, "secret");
  EXPECT_THAT(fault(files.certificate(), files.key()),
              AllOf(StartsWith("serve.key: "), HasSubstr("without a passphrase")));
}

TEST(Certificate, ThatHasExpiredIsTold) {
  const CertificateFiles files(-60);
  EXPECT_EQ(fault(files.certificate(), files.key()),
            "serve.certificate: " + files.certificate() +
                " has expired; make a new one, or correct this computer's clock");
  EXPECT_THROW(WebServer(with(files.certificate(), files.key()), {}), InputError);
}

}  // namespace
}  // namespace nadir::serve

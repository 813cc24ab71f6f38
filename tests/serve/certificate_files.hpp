// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Self-signed certificates and their keys, made for a test.
#pragma once

#include <openssl/pem.h>
#include <openssl/rsa.h>
#include <openssl/x509v3.h>
#include <stdlib.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

namespace nadir::serve {

template <auto kFree>
struct Freed {
  template <class T>
  void operator()(T* t) const {
    kFree(t);
  }
};

/// A certificate of 127.0.0.1 and its key in a folder of their own, gone with it.
class CertificateFiles {
 public:
  enum class Kind { elliptic, rsa };
  /// expires_s: from now.
  explicit CertificateFiles(long expires_s = 3600, Kind kind = Kind::elliptic,
                            const char* passphrase = nullptr) {
    std::string name = (std::filesystem::temp_directory_path() / "nadir-tls-XXXXXX").string();
    folder = ::mkdtemp(name.data());
    const std::unique_ptr<EVP_PKEY, Freed<EVP_PKEY_free>> made(
        kind == Kind::rsa ? EVP_RSA_gen(2048) : EVP_EC_gen("P-256"));
    const std::unique_ptr<X509, Freed<X509_free>> x509(X509_new());
    X509_set_version(x509.get(), X509_VERSION_3);
    ASN1_INTEGER_set(X509_get_serialNumber(x509.get()), 1);
    X509_gmtime_adj(X509_getm_notBefore(x509.get()), -7200);
    X509_gmtime_adj(X509_getm_notAfter(x509.get()), expires_s);
    X509_NAME* const subject = X509_get_subject_name(x509.get());
    X509_NAME_add_entry_by_txt(subject, "CN", MBSTRING_ASC,
                               reinterpret_cast<const unsigned char*>("nadir"), -1, -1, 0);
    X509_set_issuer_name(x509.get(), subject);
    const std::unique_ptr<X509_EXTENSION, Freed<X509_EXTENSION_free>> names(
        X509V3_EXT_conf_nid(nullptr, nullptr, NID_subject_alt_name, "IP:127.0.0.1"));
    X509_add_ext(x509.get(), names.get(), -1);
    X509_set_pubkey(x509.get(), made.get());
    X509_sign(x509.get(), made.get(), EVP_sha256());

    std::FILE* file = std::fopen(certificate().c_str(), "w");
    PEM_write_X509(file, x509.get());
    std::fclose(file);
    file = std::fopen(key().c_str(), "w");
    PEM_write_PrivateKey(file, made.get(), passphrase ? EVP_aes_128_cbc() : nullptr, nullptr, 0,
                         nullptr, const_cast<char*>(passphrase));
    std::fclose(file);
  }
  CertificateFiles(const CertificateFiles&) = delete;
  CertificateFiles& operator=(const CertificateFiles&) = delete;
  ~CertificateFiles() { std::filesystem::remove_all(folder); }

  std::string certificate() const { return folder / "certificate.pem"; }
  std::string key() const { return folder / "key.pem"; }

  std::filesystem::path folder;
};

}  // namespace nadir::serve

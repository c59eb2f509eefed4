#include "sync/transport/tls_identity.h"

#include <openssl/bio.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/sha.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <array>
#include <cstring>
#include <memory>

namespace tandem::sync {
namespace {

template <auto Free>
struct Freer {
  template <typename T>
  void operator()(T* pointer) const {
    Free(pointer);
  }
};
using BioPtr = std::unique_ptr<BIO, Freer<BIO_free_all>>;
using KeyPtr = std::unique_ptr<EVP_PKEY, Freer<EVP_PKEY_free>>;
using CertificatePtr = std::unique_ptr<X509, Freer<X509_free>>;

using Pin = std::array<unsigned char, SHA256_DIGEST_LENGTH>;
constexpr long kCertificateDays = 3650;  // the pin, not the date, is what a site checks

std::string textOf(BIO* bio) {
  char* data = nullptr;
  const long size = BIO_get_mem_data(bio, &data);
  return {data, static_cast<std::size_t>(size)};
}

CertificatePtr parseCertificate(const std::string& pem) {
  const BioPtr bio(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
  return CertificatePtr(PEM_read_bio_X509(bio.get(), nullptr, nullptr, nullptr));
}

/// SHA-256 of the DER SubjectPublicKeyInfo (RFC 7469, section 2.4).
bool pinOfCertificate(X509* certificate, Pin& pin) {
  unsigned char* der = nullptr;
  const int size = i2d_X509_PUBKEY(X509_get_X509_PUBKEY(certificate), &der);
  if (size <= 0) return false;
  SHA256(der, static_cast<std::size_t>(size), pin.data());
  OPENSSL_free(der);
  return true;
}

int hexValue(char digit) {
  if (digit >= '0' && digit <= '9') return digit - '0';
  if (digit >= 'a' && digit <= 'f') return digit - 'a' + 10;
  if (digit >= 'A' && digit <= 'F') return digit - 'A' + 10;
  return -1;
}

bool parsePin(const std::string& text, Pin& pin) {
  if (text.size() != 2 * pin.size()) return false;
  for (std::size_t i = 0; i < pin.size(); ++i) {
    const int high = hexValue(text[2 * i]), low = hexValue(text[2 * i + 1]);
    if (high < 0 || low < 0) return false;
    pin[i] = static_cast<unsigned char>(high << 4 | low);
  }
  return true;
}

void freePin(void*, void* pin, CRYPTO_EX_DATA*, int, long, void*) { delete static_cast<Pin*>(pin); }

/// The slot of an SSL_CTX for the pin that the peer's key must have.
int pinSlot() {
  static const int slot = SSL_CTX_get_ex_new_index(0, nullptr, nullptr, nullptr, freePin);
  return slot;
}

/// Replaces OpenSSL's certificate check: the handshake fails unless the key has the pin of the join link.
int verifyPin(X509_STORE_CTX* store, void*) {
  const auto* ssl =
      static_cast<const SSL*>(X509_STORE_CTX_get_ex_data(store, SSL_get_ex_data_X509_STORE_CTX_idx()));
  const auto* expected = static_cast<const Pin*>(SSL_CTX_get_ex_data(SSL_get_SSL_CTX(ssl), pinSlot()));
  X509* certificate = X509_STORE_CTX_get0_cert(store);
  Pin seen{};
  const bool same = certificate != nullptr && pinOfCertificate(certificate, seen) &&
                    CRYPTO_memcmp(seen.data(), expected->data(), seen.size()) == 0;
  X509_STORE_CTX_set_error(store, same ? X509_V_OK : X509_V_ERR_CERT_UNTRUSTED);
  return same ? 1 : 0;
}

std::unique_ptr<SslContext> baseContext(SslContext::method method) {
  auto context = std::make_unique<SslContext>(method);
  SSL_CTX* raw = context->native_handle();
  SSL_CTX_set_min_proto_version(raw, TLS1_3_VERSION);
  SSL_CTX_set_max_proto_version(raw, TLS1_3_VERSION);
  // TLS does not resume connections: a site resumes by the session's own ticket, which the server checks
  // against its journal.
  SSL_CTX_set_session_cache_mode(raw, SSL_SESS_CACHE_OFF);
  SSL_CTX_set_num_tickets(raw, 0);
  return context;
}

KeyPtr makeKey() {
  KeyPtr key(EVP_PKEY_Q_keygen(nullptr, nullptr, "ED25519"));
  if (!key) key.reset(EVP_PKEY_Q_keygen(nullptr, nullptr, "EC", "P-256"));
  return key;
}

CertificatePtr makeCertificate(EVP_PKEY* key) {
  CertificatePtr certificate(X509_new());
  std::uint64_t serial = 0;
  RAND_bytes(reinterpret_cast<unsigned char*>(&serial), sizeof serial);
  ASN1_INTEGER_set_uint64(X509_get_serialNumber(certificate.get()), serial >> 1);
  X509_set_version(certificate.get(), X509_VERSION_3);
  X509_gmtime_adj(X509_getm_notBefore(certificate.get()), -24 * 3600L);
  X509_gmtime_adj(X509_getm_notAfter(certificate.get()), kCertificateDays * 24 * 3600L);
  X509_NAME* name = X509_get_subject_name(certificate.get());
  const auto* text = reinterpret_cast<const unsigned char*>("tandem-server");
  X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC, text, -1, -1, 0);
  X509_set_issuer_name(certificate.get(), name);
  X509_set_pubkey(certificate.get(), key);
  const EVP_MD* digest = EVP_PKEY_is_a(key, "ED25519") != 0 ? nullptr : EVP_sha256();
  if (X509_sign(certificate.get(), key, digest) == 0) return nullptr;
  return certificate;
}

}  // namespace

Result<TlsIdentity> makeTlsIdentity() {
  const KeyPtr key = makeKey();
  if (!key) return Error{"cannot make a private key: OpenSSL offers neither Ed25519 nor P-256"};
  const CertificatePtr certificate = makeCertificate(key.get());
  const BioPtr keyText(BIO_new(BIO_s_mem())), certificateText(BIO_new(BIO_s_mem()));
  if (!certificate ||
      PEM_write_bio_PrivateKey(keyText.get(), key.get(), nullptr, nullptr, 0, nullptr, nullptr) == 0 ||
      PEM_write_bio_X509(certificateText.get(), certificate.get()) == 0) {
    return Error{"cannot make a certificate: OpenSSL refused to sign it"};
  }
  return TlsIdentity{textOf(keyText.get()), textOf(certificateText.get())};
}

Result<std::string> pinOf(const TlsIdentity& identity) {
  const CertificatePtr certificate = parseCertificate(identity.certificate);
  Pin pin{};
  if (!certificate || !pinOfCertificate(certificate.get(), pin))
    return Error{"the server's certificate cannot be read"};
  const BioPtr keyText(
      BIO_new_mem_buf(identity.privateKey.data(), static_cast<int>(identity.privateKey.size())));
  const KeyPtr key(PEM_read_bio_PrivateKey(keyText.get(), nullptr, nullptr, nullptr));
  if (!key || X509_check_private_key(certificate.get(), key.get()) != 1)
    return Error{"the server's private key cannot be read, or is not that of its certificate"};
  std::string text;
  for (const unsigned char byte : pin) {
    text += "0123456789abcdef"[byte >> 4];
    text += "0123456789abcdef"[byte & 15];
  }
  return text;
}

Result<std::unique_ptr<SslContext>> serverContext(const TlsIdentity& identity) {
  auto context = baseContext(SslContext::tls_server);
  boost::system::error_code failure;
  context->use_certificate(boost::asio::buffer(identity.certificate), SslContext::pem, failure);
  if (failure) return Error{"the server's certificate cannot be read: " + failure.message()};
  context->use_private_key(boost::asio::buffer(identity.privateKey), SslContext::pem, failure);
  if (failure) return Error{"the server's private key cannot be used: " + failure.message()};
  return context;
}

Result<std::unique_ptr<SslContext>> clientContext(const std::string& pin) {
  Pin wanted{};
  if (!parsePin(pin, wanted)) return Error{"the pin of the server's key must have 64 hexadecimal digits"};
  auto context = baseContext(SslContext::tls_client);
  SSL_CTX* raw = context->native_handle();
  SSL_CTX_set_ex_data(raw, pinSlot(), std::make_unique<Pin>(wanted).release());
  SSL_CTX_set_verify(raw, SSL_VERIFY_PEER, nullptr);
  SSL_CTX_set_cert_verify_callback(raw, verifyPin, nullptr);
  return context;
}

bool failedByPin(SSL* ssl) { return SSL_get_verify_result(ssl) == X509_V_ERR_CERT_UNTRUSTED; }

}  // namespace tandem::sync

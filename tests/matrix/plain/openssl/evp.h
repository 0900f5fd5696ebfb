// What the conformance adapter of libfvv takes of OpenSSL, for machines whose OpenSSL is not here.
#pragma once

#include <cstddef>

struct EVP_MD;
const EVP_MD *EVP_sha256();
int EVP_Digest(const void *bytes, size_t size, unsigned char *digest, unsigned *digest_size,
               const EVP_MD *type, void *engine);
int EVP_DecodeBlock(unsigned char *out, const unsigned char *text, int size);

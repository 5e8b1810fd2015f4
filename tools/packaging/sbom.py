#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The bill of materials of a release, SPDX 2.3 as JSON, and SHA256SUMS.

    sbom.py FOLDER VERSION EPOCH     FOLDER holds what is released; EPOCH: the time of the commit, seconds

Each file is a package with its sum, and is related to what is compiled into it (STATIC_LINK) or lies in it (CONTAINS), with versions and
licences. The same files give the same bytes.
"""
import hashlib
import json
import pathlib
import re
import sys
import tarfile
import time

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import notices  # noqa: E402

COMMENTS = {
    "sample-built-in.glb": ("Apache-2.0", "What doppel sample-avatar makes."),
    "sample-realistic.glb": ("NOASSERTION", "A reconstruction; its licence is that of the scan that it was made from."),
}


def bundled(archive):
    """The lines that bundle.py left in an archive: relation, name, version, licence."""
    with tarfile.open(archive) as tar:
        for member in tar:
            if member.name.endswith("/licences/contents.txt"):
                return tar.extractfile(member).read().decode().splitlines()
    sys.exit(f"{archive}: no licences/contents.txt is inside")


def inside(file):
    """What is compiled into a released file, or lies in it: (relation, name, version, licence)."""
    if file.name in COMMENTS:
        return []
    what = file.name.split("_")[0] if file.suffix == ".deb" else {".zip": "windows", ".tgz": "web"}.get(file.suffix, "linux")
    found = [("STATIC_LINK", name, notices.version_of(name), licence) for name, licence in sorted(notices.COMPILED_IN[what].items())]
    if what == "linux":
        found += [tuple(line.split(" ", 3)) for line in bundled(file)]
    return found


def spdx_id(*parts):
    return "SPDXRef-" + re.sub(r"[^A-Za-z0-9.-]", "-", "-".join(parts))


def document(folder, version, epoch):
    created = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(epoch))
    packages, relations, known = [], [], set()
    sums = []
    for file in sorted(f for f in folder.iterdir() if f.name not in ("SHA256SUMS", f"doppel-{version}.spdx.json")):
        digest = hashlib.sha256(file.read_bytes()).hexdigest()
        sums.append(f"{digest}  {file.name}")
        licence, comment = COMMENTS.get(file.name, ("Apache-2.0", "Other licences inside: STATIC_LINK and CONTAINS."))
        packages.append({"SPDXID": spdx_id(file.name), "name": file.name, "versionInfo": version, "packageFileName": file.name,
                         "downloadLocation": "NOASSERTION", "filesAnalyzed": False, "licenseConcluded": licence, "licenseDeclared": licence,
                         "copyrightText": "Copyright 2026 The Doppel authors", "comment": comment,
                         "checksums": [{"algorithm": "SHA256", "checksumValue": digest}]})
        relations.append({"spdxElementId": "SPDXRef-DOCUMENT", "relationshipType": "DESCRIBES", "relatedSpdxElement": spdx_id(file.name)})
        for relation, name, itsVersion, itsLicence in inside(file):
            identity = spdx_id(name, itsVersion)
            if identity not in known:
                known.add(identity)
                packages.append({"SPDXID": identity, "name": name, "versionInfo": itsVersion, "downloadLocation": "NOASSERTION",
                                 "filesAnalyzed": False, "licenseConcluded": itsLicence, "licenseDeclared": itsLicence,
                                 "copyrightText": "NOASSERTION", "comment": "As Debian packages it; its copyright file is inside.",
                                 "externalRefs": [{"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl",
                                                   "referenceLocator": f"pkg:deb/debian/{name}@{itsVersion.replace('+', '%2B')}"}]})
            relations.append({"spdxElementId": spdx_id(file.name), "relationshipType": relation, "relatedSpdxElement": identity})
    listed = "\n".join(sums) + "\n"
    return listed, {
        "spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT", "name": f"doppel-{version}",
        "documentNamespace": f"urn:doppel:release:{version}:{hashlib.sha256(listed.encode()).hexdigest()[:32]}",
        "creationInfo": {"created": created, "creators": ["Organization: The Doppel authors", "Tool: tools/release"]},
        "hasExtractedLicensingInfos": [{"licenseId": "LicenseRef-public-domain", "name": "public domain",
                                        "extractedText": "Its authors have put it into the public domain; see its copyright file."}],
        "packages": packages, "relationships": relations}


def main():
    if len(sys.argv) != 4 or {"-h", "--help"} & set(sys.argv[1:]):
        print(__doc__, file=sys.stderr)
        return 2
    folder, version = pathlib.Path(sys.argv[1]), sys.argv[2]
    listed, bill = document(folder, version, int(sys.argv[3]))
    name = f"doppel-{version}.spdx.json"
    (folder / name).write_text(json.dumps(bill, indent=1) + "\n")
    listed += f"{hashlib.sha256((folder / name).read_bytes()).hexdigest()}  {name}\n"
    (folder / "SHA256SUMS").write_text(listed)
    print(f"{name}: {len(bill['packages'])} packages, {len(bill['relationships'])} relations")
    return 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""seeds.py DIRECTORY: writes what the fuzzers start from, a folder per reader."""

import json
import pathlib
import struct
import sys

IDENTITY = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"


def pcd(fields="x y z", sizes="4 4 4", types="F F F", counts="1 1 1", width=2, height=1, points=2, encoding="ascii",
        body=b"1 2 3\n4 5 6\n", more=""):
    return (f"# .PCD v0.7\nVERSION 0.7\nFIELDS {fields}\nSIZE {sizes}\nTYPE {types}\nCOUNT {counts}\nWIDTH {width}\n"
            f"HEIGHT {height}\nVIEWPOINT 0 0 0 1 0 0 0\n{more}POINTS {points}\nDATA {encoding}\n").encode() + body


def packed(plain):
    """LZF, as literals."""
    data = b"".join(bytes([len(plain[i:i + 32]) - 1]) + plain[i:i + 32] for i in range(0, len(plain), 32))
    return struct.pack("<II", len(data), len(plain)) + data


ROWS = struct.pack("<6f", 1, 2, 3, 4, 5, 6)
COLUMNS = struct.pack("<6f", 1, 4, 2, 5, 3, 6)
WRAPPING = {"fields": " ".join(f"f{i}" for i in range(8192)), "sizes": " ".join(["8"] * 8192),
            "types": " ".join(["F"] * 8192), "counts": " ".join(["65536"] * 8192), "body": b""}

PCD = {
    "ascii": pcd(),
    "binary": pcd(encoding="binary", body=ROWS),
    "compressed": pcd(encoding="binary_compressed", body=packed(COLUMNS)),
    "compressed_runs": pcd(width=64, points=64, encoding="binary_compressed",
                           body=struct.pack("<II", 7, 768) + b"\x00\x00\xe0\xff\x00\xe0\xff"),
    "organised": pcd(width=1, height=2),
    "all_types": pcd("x y z a b c d e f g h", "4 8 4 1 1 2 2 4 4 8 8", "F F F I U I U I U I U", " ".join(["1"] * 11),
                     1, 1, 1, body=b"1 2 nan -1 255 -2 65535 -3 4294967295 -4 5\n"),
    "counts": pcd("x y z h", "4 4 4 4", "F F F F", "1 1 1 3", body=b"1 2 3 4 5 6\n1 2 3 4 5 6\n"),
    "padding": pcd("x y z _", "4 4 4 1", "F F F U", "1 1 1 0"),
    "huge": pcd(body=b"1e400 -1e400 1e-400\ninf -inf nan\n"),
    "greatest_float": pcd(body=b"3.4028235e+38 -3.4028235e+38 1e-45\n1 2 3\n"),
    "few_words": b"FIELDS x y z\nPOINTS 1\nDATA ascii\n1 2 3\n",
    "crlf": pcd().replace(b"\n", b"\r\n"),
    "short": pcd(points=100, width=100),
    "step_wraps": pcd(**WRAPPING),
    "step_wraps_binary": pcd(**{**WRAPPING, "encoding": "binary", "body": ROWS}),
    "step_wraps_compressed": pcd(**{**WRAPPING, "encoding": "binary_compressed", "body": packed(ROWS)}),
    "size_wraps": pcd(width=4294967295, height=4294967295, points=1),
    "viewpoint_nan": pcd().replace(b"VIEWPOINT 0 0 0 1 0 0 0", b"VIEWPOINT nan 0 0 nan 0 0 0"),
}


def ply(encoding="ascii", properties="float x\nfloat y\nfloat z", body=b"1 2 3\n4 5 6\n", count=2, before="", after=""):
    lines = "".join(f"property {line}\n" for line in properties.split("\n"))
    return (f"ply\nformat {encoding} 1.0\ncomment c\n{before}element vertex {count}\n{lines}{after}"
            "end_header\n").encode() + body


FACES = "element face 1\nproperty list uchar int vertex_indices\n"
PLY = {
    "ascii": ply(),
    "little": ply("binary_little_endian", body=ROWS),
    "big": ply("binary_big_endian", body=struct.pack(">6f", 1, 2, 3, 4, 5, 6)),
    "colours": ply(properties="float x\nfloat y\nfloat z\nuchar red\nuchar green\nuchar blue\nuchar alpha",
                   body=b"1 2 3 4 5 6 7\n1 2 3 255 0 255 0\n"),
    "types": ply(properties="char a\nuchar b\nshort c\nushort d\nint e\nuint f\nfloat32 x\nfloat64 y\nfloat64 z",
                 body=b"-1 255 -2 65535 -3 4294967295 1 2 3\n" * 2),
    "faces_behind": ply(body=b"1 2 3\n4 5 6\n3 0 1 1\n", after=FACES),
    "faces_before": ply(body=b"3 0 1 1\n1 2 3\n4 5 6\n", before=FACES),
    "faces_before_binary": ply("binary_little_endian", body=b"\x03" + bytes(12) + ROWS, before=FACES),
    "list_of_a_vertex": ply(properties="float x\nfloat y\nfloat z\nlist uchar int l", body=b"1 2 3 1 7\n4 5 6 0\n"),
    "list_of_a_vertex_binary": ply("binary_little_endian", "float x\nfloat y\nfloat z\nlist uchar uchar l",
                                   ROWS[:12] + b"\x01\x07" + ROWS[12:] + b"\x00"),
    "signed_list_length": ply("binary_little_endian", body=b"\xff" + ROWS,
                              before="element face 1\nproperty list char int l\n"),
    "grid": ply(before="obj_info num_cols 1\nobj_info num_rows 2\n"),
    "empty": b"",
    "blank_lines": b" \n\n\t\n",
    "many": ply(count=4294967295),
    "nothing_many_times": ply(before="element nothing 4294967295\n"),
    "no_name": ply(properties="float x\nfloat y\nfloat z\nfloat", body=b"1 2 3 4\n4 5 6 7\n"),
}

TEXT = {
    "rows": "1 2 3\n4 5 6\n",
    "commas": "1,2,3\n4,5,6\n",
    "semicolons": "X;Y;Z\r\n1;2;3\r\n4;5;6\r\n",
    "tabs": "1\t2\t3\n",
    "cloudcompare": "//X Y Z R G B\n2\n1 2 3 9 9 9\n4 5 6 9 9 9\n",
    "pts": "2\n1 2 3 -900 10 20 30\n4 5 6 -900 10 20 30\n",
    "named": '"id","Z","Y","X"\n1,3,2,1\n"a",6,5,4\n',
    "comments": "# a\n\n  // b\n1 2 3\n#\n4 5 6",
    "carriage_returns": "1 2 3\r4 5 6\r",
    "mark": "\ufeffx y z\n1 2 3\n",
    "guessed": "1 2 3 0.5\n4 5 6 tree\n",
    "utm": "512345.678 5403210.987 312.3\n512346.678 5403211.987 313.3\n",
    "spellings": "nan 1.#QNAN none\n+1 1d0 0x1p3\n1e999 -inf 1e-400\n",
    "decimal_commas": "1,5;2,5;3,5\n",
    "decimal_commas_between": "x,y,z\n1,5,2,5,3,5\n",
    "empty_column": "x,y,z\n1,,3\n",
    "short_row": "1 2 3\n4 5\n",
    "promises": "18446744073709551615\n1 2 3\n",
    "twice": "x,X,y,z\n1,2,3,4\n",
    "nul": b"1 2 3\n4 5\0 6\n",
    "only_separators": ",,;;,,\n",
    "nothing": "#\n//\n",
}


def las(minor, point_format, record, points=2, promised=None):
    """A header as ASPRS has it, and points that are all zero."""
    size = 227 if minor < 4 else 375
    promised = points if promised is None else promised
    header = struct.pack("<4s20xBB68xHIIBHI20x6d6d", b"LASF", 1, minor, size, size, 0, point_format, record,
                         promised if minor < 4 else 0, 0.01, 0.01, 0.5, 1, -2, 3, 1, 0, 1, 0, 1, 0)
    return header + (struct.pack("<20xQ120x", promised) if minor >= 4 else b"") + bytes(points * record)


LAS = {
    "plain": las(2, 0, 20),
    "with_time": las(2, 1, 28),
    "longer_records": las(3, 3, 40),
    "wide": las(4, 6, 30),
    "promises": las(2, 0, 20, promised=2**32 - 1),
    "promises_more": las(4, 6, 30, promised=2**64 - 1),
    "compressed": las(2, 0x80, 20),
    "start_only": "LASF",
}

VTK_START = "# vtk DataFile Version 3.0\nt\n%s\nDATASET POLYDATA\nPOINTS %s\n"
VTK = {
    "ascii": VTK_START % ("ASCII", "2 float") + "1 2 3\n4 5 6\n",
    "cells": VTK_START % ("ASCII", "2 double") + "1 2 3 4 5 6\nVERTICES 1 3\n2 0 1\n",
    "binary": (VTK_START % ("BINARY", "2 float")).encode() + struct.pack(">6f", 1, 2, 3, 4, 5, 6) + b"\nMETADATA\n",
    "binary_double": (VTK_START % ("BINARY", "1 double")).encode() + struct.pack(">3d", 1, 2, 3),
    "grid": (VTK_START % ("ASCII", "1 float") + "1 2 3\n").replace("POLYDATA", "UNSTRUCTURED_GRID"),
    "promises": VTK_START % ("BINARY", "18446744073709551615 double"),
    "too_few": VTK_START % ("ASCII", "2 float") + "1.25 2.25 3.25\n",
    "too_many": VTK_START % ("ASCII", "1 float") + "1 2 3 4 5 6\n",
    "structured": (VTK_START % ("ASCII", "1 float")).replace("POLYDATA", "STRUCTURED_POINTS"),
    "start_only": "# vtk DataFile",
}

GUESSES = {
    "rows": IDENTITY,
    "one_line": IDENTITY.replace("\n", " "),
    "commas": IDENTITY.replace(" ", ","),
    "semicolons": IDENTITY.replace(" ", ";"),
    "numpy": "[[1. 0. 0. 0.]\n [0. 1. 0. 0.]\n [0. 0. 1. 0.]\n [0. 0. 0. 1.]]\n",
    "kitti": "1 0 0 0 0 1 0 0 0 0 1 0",
    "mark": "\ufeff" + IDENTITY.replace("\n", "\r\n"),
    "comment": "# about\n" + IDENTITY.replace("0\n", "0 # row\n"),
    "mirrors": IDENTITY.replace("0 0 1 0", "0 0 -1 0"),
    "scales": "2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1",
    "transposed": "1 0 0 0 0 1 0 0 0 0 1 0 1 2 3 1",
    "last_row": "1 0 0 0 0 1 0 0 0 0 1 0 1e-17 0 0 1.0000001",
    "huge": "1e308 0 0 0 0 1e308 0 0 0 0 1e308 0 0 0 0 1",
    "quarter_turn": "0 -1 0 1e9 1 0 0 -1e-9 0 0 1 +3 0 0 0 1",
    "few_digits": "0.990 -0.139 0.012 0.004 0.139 0.986 -0.086 -0.003 0.000 0.087 0.996 0.002 0 0 0 1",
    "nan": "nan 0 0 0 0 1 0 0 0 0 1 0",
    "nul_bytes": "1 0 0 0 0 1 0 0 0 \0\0\0",
}

CSV = {
    "plain": "source,target\na.pcd,b.ply\n",
    "options": "source,target,leaf,reciprocal,iterations,metric,guess,trim\n"
               "a,b,0.1,true,3,plane,,\nc,d,,,,,g.txt,0.5\n",
    "mark_upper_crlf": "\ufeffSOURCE,Target\r\na,b\r\n",
    "semicolons": "source;target;guess\na;b;1 0 0 0 0 1 0 0 0 0 1 0\n",
    "tabs": "source\ttarget\na\tb\n",
    "quotes": 'source,target\n"a ""1"", x","b\nc"\n "a" , "b" \n',
    "blanks": " source , target \n a , b c \n\n,\n  \n",
    "comments": "# c\nsource,target\n#a\na,b\n  # c",
    "carriage_returns": "source,target\ra,b\r",
    "open_quote": 'source,target\n"a,b\n',
    "bracketed": "source,target,guess,leaf\na,b,\"[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]\",[1]\n",
    "utf16": "source,target\na,b\n".encode("utf-16"),
    "latin1": "source,target\n\xe9,\xe8\n".encode("latin-1"),
    "nul": b"source,target\na\0b,c\n",
    "twice": "source,target,Source\na,b,c\n",
}

PAIR = {"source": "a.pcd", "target": "b.ply"}
MATRIX = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
JSON = {
    "plain": json.dumps(PAIR),
    "options": json.dumps({**PAIR, "leaf": 0.1, "reciprocal": True, "iterations": 3, "metric": "plane", "trim": None}),
    "guess": json.dumps({**PAIR, "guess": MATRIX}),
    "guess_file": json.dumps({**PAIR, "GUESS": "g.txt"}),
    "lines": "\n" + json.dumps(PAIR) + "\r\n \n" + json.dumps(PAIR),
    "nested_arrays": '{"source": ' + "[" * 50000 + "]" * 50000 + "}",
    "nested_objects": '{"source": ' + '{"a": ' * 50000 + "1" + "}" * 50000 + "}",
    "not_closed": "[" * 100000,
    "twice": '{"source": "a", "source": "b", "target": "c"}',
    "twice_by_case": '{"source": "a", "SOURCE": "b", "target": "c"}',
    "huge_numbers": '{"source": "a", "target": "b", "leaf": 1e999, "iterations": 99999999999999999999999}',
    "nul": b'{"source": "a", "target": "b"}\0{',
    "escaped_nul": '{"source": "a\\u0000b", "target": "b"}',
    "invalid_utf8": b'{"source": "\xff\xfe", "target": "b"}',
    "lone_surrogate": '{"source": "\\ud800", "target": "b"}',
}


def result(**members):
    return json.dumps({"pair": 0, "source": "s.pcd", "target": "t.pcd", "options": {}, "status": "converged",
                       "transform": MATRIX, "reason": "transform", "iterations": 3, "rmse": 0.5, "verdict": "doubtful",
                       "reasons": ["two poses fit"], "quality": {"source_near": {"before": 0.5, "after": 0.9}}, **members}) + "\n"


RESULTS = {
    "converged": result(),
    "three": result() + result(pair=1, rmse=None) + result(pair=2, options={"leaf": "0.5"}),
    "failed": result(status="failed", error={"kind": "input", "message": "a.pcd: is empty"}),
    "not_converged": result(status="not converged", ending="got worse", why="stopped at the limit"),
    "at_the_limit": result(status="at the limit"),
    "twice": result() * 2,
    "pair_is_negative": result(pair=-1),
    "pair_is_real": result(pair=1e30),
    "pair_is_true": result(pair=True),
    "iterations_are_many": result(iterations=99999999999),
    "iterations_are_huge": result().replace('"iterations": 3', '"iterations": 1e300'),
    "numbers_overflow": result().replace("0.5", "1e999"),
    "matrix_is_flat": result(transform=[1, 0, 0, 0]),
    "matrix_is_true": result(transform=[[True] * 4] * 4),
    "options_are_a_list": result(options=["a"]),
    "member_twice": result().replace('"pair": 0', '"pair": 0, "pair": 1'),
    "nested": '{"pair": ' + "[" * 50000 + "]" * 50000 + "}\n",
    "nul": result().encode() + b"\0\n",
    "invalid_utf8": result().encode().replace(b"s.pcd", b"\xc3\x28"),
}

CLOUDS = {
    "empty": b"",
    "zeros": bytes(200),
    "all_fields": b"\0\x1f\6\1\7\2\0\0\5\0\x08\x10\x18\1\2\7\2" + bytes(range(256)) * 4,
    "double": b"\1\3\7\0\6\2" + bytes(range(255, -1, -1)) * 4,
    "wide_integers": b"\0\x0c\x08\2\x09\0" + bytes(range(256)) * 2,
    "nan": b"\0\x1f" + b"\xff" * 600,
    "data_like_a_header": b"\1flo\3\7\0\6\2\xff\xfe\xfd\xfcCOUNT" + bytes(range(255, -1, -1)) * 2,
}

SEEDS = {"pcd": PCD, "ply": PLY, "text": TEXT, "las": LAS, "vtk": VTK, "cloud": CLOUDS, "against_pcl": CLOUDS,
         "guess": GUESSES, "manifest_csv": CSV, "manifest_jsonl": JSON, "results": RESULTS}


def main(directory):
    for reader, seeds in SEEDS.items():
        folder = pathlib.Path(directory, reader)
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in seeds.items():
            (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())


if __name__ == "__main__":
    main(sys.argv[1])

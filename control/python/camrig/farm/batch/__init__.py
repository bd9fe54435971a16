"""Data sets at scale: a plan of shards, drawn by any number of workers on any number of machines, each exactly once in effect.

    plan.py       what is to be drawn: a table of variants, read from JSON    variants.py, pointer.py
    scene_file.py the scene of a variant, and the hash of all that it is made of
    shard.py      one file of the set and what it is called
    draw.py       draws one shard, in a process of its own                     shard_file.py, scratch.py
    store.py      the folder of a set: what is there, what is whole            manifest.py
    record.py     hands shards out until all are there                         pools.py, ray_pool.py, progress.py
    export.py     COCO, MOTChallenge, KITTI, YOLO and Parquet from the shards  parquet.py
"""

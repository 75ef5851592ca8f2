"""Clients that have asked once and keep their connections: COUNT of them to ADDRESS, for two minutes."""

import sys
import time

import grpc

address, count = sys.argv[1], int(sys.argv[2])
channels = []
for _ in range(count):
    channel = grpc.insecure_channel(address, options=[("grpc.use_local_subchannel_pool", 1)])
    channel.unary_unary("/cwm.v1.AdminService/GetServerInfo")(b"", timeout=60)
    channels.append(channel)
print("idle", flush=True)
time.sleep(120)
